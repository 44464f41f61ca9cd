"""Commands that look after an installation, scene files and certified solutions."""
