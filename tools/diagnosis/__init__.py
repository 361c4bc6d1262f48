"""Where the actor of a run fails: metrics and plots from its snapshots and logs."""
