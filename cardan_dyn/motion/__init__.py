"""Motion: time, vibration and clearance, on the core."""
