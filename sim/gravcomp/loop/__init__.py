"""What a diagnosis found goes into network and compensator."""
