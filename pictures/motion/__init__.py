"""Motion of a scene as a picture: the chain along its orbit, and as seen by an observer at its centre of mass."""
