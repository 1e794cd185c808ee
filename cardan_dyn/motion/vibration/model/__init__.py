"""Model: the efforts of free coordinates as interpolated functions, and their linear modes."""
