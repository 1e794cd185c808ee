"""Description: text in any notation to checked plain data, and back to text."""
