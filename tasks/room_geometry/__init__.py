"""What stands in a room, where the robot fits, and from where to where it drives."""
