"""hacheck: the independent checker of haverify reports; standard library only."""
