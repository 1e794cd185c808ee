"""What several tests share: descriptions, scenes, references derived in other ways."""
