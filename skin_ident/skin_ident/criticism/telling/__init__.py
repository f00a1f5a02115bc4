"""From a finished search to findings.json: gains by channel (`judging`), the noise floor (`floor`), what is still wrong (`leftover`), and
all of it in words and numbers (`findings`, `telling`).
"""
