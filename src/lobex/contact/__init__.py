"""What the blade rubs: contact laws and casings."""
