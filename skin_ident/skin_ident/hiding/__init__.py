"""Hide and seek: effects hidden in recordings, and campaigns that count how often the criticism finds them.

The hidden effects have the same forms that the criticism fits. Campaigns therefore show what noise, size and protocol allow; only
recordings made elsewhere show how robust the naming is to other forms.
"""
