"""Scene: what a user asks for, checked and handed on."""
