"""Diagnosis: which motions loops leave, and why drives do not decide them."""
