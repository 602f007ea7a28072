"""Maps over two states or parameters: cases of the rigid contact and their borders."""
