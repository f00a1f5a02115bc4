"""Hide and seek: effects hidden in recordings, and campaigns that count how often the criticism finds them.

What is hidden here has the very forms that the criticism can fit. It shows what noise, size and protocol allow; how robust the naming is
to other forms is shown by recordings made elsewhere.
"""
