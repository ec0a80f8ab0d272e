"""D-Wave's services and chips: the account, what each solver takes and answers, embeddings."""
