"""Telling of a stored night: its facts, the sentence, trends, JUnit."""
