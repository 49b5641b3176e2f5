"""A sensor on the first analogue input of a CiA 401 module, which is logged."""
