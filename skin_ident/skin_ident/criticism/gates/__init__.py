"""What a cause must pass before it is believed: held-out sessions predicted better (`gate`, `second_opinion`), beside what training leaves
uncertain (`uncertain`), more than what the steps of encoder and converters leave open (`resolution`) or errors of the encoder feign
(`feigned`) or hide (`blurred`), and more than noise of another colour would explain (`description`). What is asked is a `claim`.
"""
