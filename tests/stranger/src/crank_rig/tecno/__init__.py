"""A bank of two electro-pneumatic regulators, "tecno", with a code of its maker's."""
