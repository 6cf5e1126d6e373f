"""What there is: scenes, cameras and their files."""
