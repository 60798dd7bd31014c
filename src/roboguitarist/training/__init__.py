"""Training the left hand: runs that survive, whatever learner they run (extra `train`)."""
