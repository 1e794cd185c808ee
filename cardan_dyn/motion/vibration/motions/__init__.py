"""Motions: periodic motions of a model, held against its scene, and their stability."""
