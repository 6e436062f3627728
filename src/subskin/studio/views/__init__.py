"""What each view answers: from what a page asks to what it draws. Nothing here knows of sockets."""
