"""The line as it is: its data, geometry, supports, files and description."""
