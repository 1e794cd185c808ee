"""Results: what each question about a vibration is answered with."""
