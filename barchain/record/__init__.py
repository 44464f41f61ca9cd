"""What a result folder records: environment, sources, engines and scenes; its lock, its claim and its store."""
