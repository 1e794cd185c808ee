"""Elements: springs, dampers, bushings, friction and actuators, and the forces that they exert."""
