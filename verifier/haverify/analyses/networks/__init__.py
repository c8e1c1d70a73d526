"""Systems whose parts have clocks of slope one and discrete variables, explored with zones of clock values."""
