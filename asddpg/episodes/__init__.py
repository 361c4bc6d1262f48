"""Episodes: the protocols of those who take part, the one loop, who drives, and what an evaluation measures."""
