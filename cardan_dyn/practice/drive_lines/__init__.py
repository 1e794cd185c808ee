"""Drive lines: shafts and universal joints as data, their closed-chain description and analysis."""
