"""The version of haverify, and that of the language it reads."""

VERSION = "0.1.0"
LANGUAGE = "1.0"
