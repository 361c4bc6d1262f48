"""Readers of spatial rooms: Gazebo worlds and MJCF, with their meshes."""
