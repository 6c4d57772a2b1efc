"""What is played: seedings of blocks in four formats."""
