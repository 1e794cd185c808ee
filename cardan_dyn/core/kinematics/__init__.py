"""Kinematics: loops closed for many samples at once, followed from where the scene starts."""
