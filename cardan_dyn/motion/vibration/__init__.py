"""Vibration: periodic motions about a drive at constant speed, and what becomes of small ones."""
