"""Tests of what authors of engines get: the public interface, new packages, the pages."""
