"""Tables that studies write and chapters read: the only door between computing and telling."""
