"""What snapshots and logs of a run say of its actor."""
