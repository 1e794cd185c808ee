"""Diagnosis: what errors say of loops that do not close or drives that do not decide a motion."""
