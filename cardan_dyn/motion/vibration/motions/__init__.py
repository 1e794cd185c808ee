"""Motions: periodic motions, held against sweeps of their scene, and their stability."""
