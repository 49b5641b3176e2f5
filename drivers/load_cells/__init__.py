"""Load cells on the analogue inputs of CiA 401 modules."""
