"""From a finished search to findings.json: gains by channel (`judging`), what noise alone leaves (`floor`) and what is still wrong
(`leftover`), put into words and numbers (`findings`, `telling`).
"""
