"""Response: wrenches as functions of the drive's position."""
