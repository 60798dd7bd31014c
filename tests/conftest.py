"""Being here puts this folder on the import path of the tests in the folders below."""
