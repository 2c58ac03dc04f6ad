"""New tokens of keys and new secrets of webhooks beside those before them."""

from __future__ import annotations

import base64
import hashlib
import hmac

import pytest
from garmentq.service.keys import (
    GraceBad,
    KeyBad,
    KeyRevoked,
    KeyUnknown,
    authenticate_token,
    create_key,
    revoke_key,
    rotate_key,
)
from garmentq.service.models import ApiKeyRow, WebhookRow
from garmentq.service.webhook_delivery import sign
from garmentq.service.webhooks import (
    Message,
    WebhookUnknown,
    claim_due_messages,
    create_webhook,
    queue_trial,
    rotate_secret,
)


def is_valid(database, token: str) -> bool:
    """Check whether a token authenticates."""
    try:
        authenticate_token(database, token)
    except KeyBad:
        return False
    return True


def expire(database, table, key: str) -> None:
    """Let the time of what was before pass."""
    with database.write() as session:
        session.get(table, key).earlier_until -= 30 * 86400.0


def test_a_key_has_two_tokens_for_a_time(database):
    """Broken where the old token ends before the new one is everywhere, or never; or a key changes by it."""
    row, first = create_key(database, "studio", ("read", "submit"), 7, 3)
    rotated, second = rotate_key(database, row.id)
    assert first != second and is_valid(database, first) and is_valid(database, second)
    assert authenticate_token(database, second) == authenticate_token(database, first)
    assert authenticate_token(database, second).key == row.id and (rotated.quota, rotated.priority) == (7, 3)
    assert 23.9 < (rotated.earlier_until - row.created) / 3600.0 < 24.1
    expire(database, ApiKeyRow, row.id)
    assert not is_valid(database, first) and is_valid(database, second)


def test_only_the_last_token_stays_beside(database):
    """Broken where a leaked token lives on by further rotations, or one of no grace is taken."""
    row, first = create_key(database, "studio", ("read",))
    _, second = rotate_key(database, row.id, 100.0)
    _, third = rotate_key(database, row.id, 1.0)
    assert [is_valid(database, one) for one in (first, second, third)] == [False, True, True]
    _, fourth = rotate_key(database, row.id, 0.0)
    assert [is_valid(database, one) for one in (first, second, third, fourth)] == [False, False, False, True]


def test_a_revoked_key_ends_with_both_tokens(database):
    """Broken where the token before outlives its key, or a revoked key gets a new one."""
    row, first = create_key(database, "studio", ("read",))
    _, second = rotate_key(database, row.id)
    revoke_key(database, row.id)
    assert not is_valid(database, first) and not is_valid(database, second)
    with pytest.raises(KeyRevoked):
        rotate_key(database, row.id)
    with pytest.raises(KeyUnknown):
        rotate_key(database, "nosuch")


@pytest.mark.parametrize("hours", [-1.0, 168.1, float("nan"), float("inf")])
def test_the_grace_is_bounded(database, hours):
    """Broken where what may have leaked stays valid for ever."""
    row, _ = create_key(database, "studio", ("read",))
    hook, _ = create_webhook(database, "https://studio.example/", [], "", row.id)
    for rotate, name in ((rotate_key, row.id), (rotate_secret, hook.id)):
        with pytest.raises(GraceBad):
            rotate(database, name, hours)


def claim_trial(database, webhook: str) -> Message:
    """Queue a message and claim it, whoever claimed one before."""
    queue_trial(database, webhook)
    with database.write() as session:
        session.get(WebhookRow, webhook).taken_until = 0.0
    (message,) = claim_due_messages(database, 1)
    return message


def test_messages_have_two_signatures_for_a_time(database):
    """Broken where a receiver that has only the old secret, or only the new one, refuses messages of that time."""
    hook, first = create_webhook(database, "https://studio.example/", [], "")
    assert claim_trial(database, hook.id).earlier_secret is None
    rotated, second = rotate_secret(database, hook.id)
    message = claim_trial(database, hook.id)
    assert (message.secret, message.earlier_secret) == (second, first) and rotated.earlier_until is not None
    expire(database, WebhookRow, hook.id)
    message = claim_trial(database, hook.id)
    assert (message.secret, message.earlier_secret) == (second, None)
    key = base64.b64decode(second.removeprefix("whsec_"))
    digest = hmac.new(key, b"m.7.{}", hashlib.sha256).digest()
    assert sign(second, "m", 7, b"{}") == "v1," + base64.b64encode(digest).decode()


def test_another_keys_secret_is_not_rotated(database):
    """Broken where a key cuts off the messages of another one."""
    ours, theirs = (create_key(database, name, ("submit",))[0].id for name in ("ours", "theirs"))
    hook, _ = create_webhook(database, "https://studio.example/", [], "", theirs)
    with pytest.raises(WebhookUnknown):
        rotate_secret(database, hook.id, key=ours)
