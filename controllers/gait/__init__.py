"""Walking of two legs through their straight knees.

References
----------
Kameta, Sekiguchi, Tsumaki and Nenchev, "Walking control around singularity using the SC approach":
"Kameta et al." in this folder.
"""
