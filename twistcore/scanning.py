"""The scanner of numbers, for numba alone: :mod:`twistcore.compiled` imports it with numba.

A usual number, such as ``-12.345678 ``, is read as two integers of eight bytes each, one before and
one behind the point, whose digits are added up side by side: neighbours first, then pairs, then
fours. Everything else is read byte by byte. Indices into bytes are unsigned, so that none is looked
at twice for being negative.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from numba import types
from numba.extending import intrinsic, register_jitable
from numpy.typing import NDArray

from twistcore.rotation import Array

_Bytes = NDArray[np.uint8]
_Integers = NDArray[np.int64]

_ONE, _TEN, _NONE = np.uint64(1), np.uint64(10), np.uint64(0)
_MOST_DIGITS = np.uint64(19)  # 10¹⁹ < 2⁶⁴
_EXACT = np.uint64(2**53)

_EIGHT, _ALL_BITS = np.uint64(8), np.uint64(64)
_REACH = np.uint64(16)  # 7 bytes, the point and 8 decimals; a blank stands behind them
# In each of eight bytes:
_DIGIT = np.uint64(0x1010101010101010)  # a bit that digits have, but no point, sign or white space
_DIGIT_BUT_FIRST = np.uint64(0x1010101010101000)
_ZEROS = np.uint64(0x3030303030303030)  # the character 0
_SIX, _HIGH = np.uint64(0x0606060606060606), np.uint64(0xF0F0F0F0F0F0F0F0)
_SIGN = np.uint64(ord("-") ^ ord("0"))  # makes a 0 of a minus
_PAIRS = np.uint64(0x000000FF000000FF)
_FROM_A_AND_C = np.uint64(100 + (1_000_000 << 32))
_FROM_B_AND_D = np.uint64(1 + (10_000 << 32))


def _load(_typing: Any, address: Any) -> Any:
    """Eight bytes at any address as one integer, the first of them the lowest."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointer = context.get_value_type(signature.return_type).as_pointer()
        word = builder.load(builder.inttoptr(arguments[0], pointer), align=1)
        return word if sys.byteorder == "little" else builder.bswap(word)

    return types.uint64(address), generate


def _zeros_below(_typing: Any, mask: Any) -> Any:
    """How many bits are 0 below the lowest 1; 64 without any."""

    def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.cttz(arguments[0], context.get_constant(types.boolean, False))

    return types.uint64(mask), generate


def _eight_digits(digits: np.uint64) -> np.uint64:
    """The number whose digits, 0 to 9, are these bytes.

    Of four pairs a, b, c, d, the first in the lowest bytes, a and c are multiplied at once, then b
    and d; the upper halves of the products add up to a·10⁶ + c·10² and b·10⁴ + d.
    """
    pairs = digits * _TEN + (digits >> _EIGHT)
    ac, bd = pairs & _PAIRS, (pairs >> np.uint64(16)) & _PAIRS
    return (ac * _FROM_A_AND_C + bd * _FROM_B_AND_D) >> np.uint64(32)


load, zeros_below = intrinsic(_load), intrinsic(_zeros_below)
eight_digits = register_jitable(_eight_digits)


def scan(
    x: _Bytes, powers: Array, values: Array, lines: _Integers, odd: _Integers
) -> tuple[np.uint64, np.uint64, np.uint64]:
    """The numbers of a block of text: how many, how many line breaks, how many odd tokens.

    powers: 10⁰ … 10²². values: room for every number; lines: how many had been read at each break;
    odd: (index of the value, start, end) of every token that is left to float(): not an integer up
    to 2⁵³ times or over one of the powers, whose product or quotient is correctly rounded.
    """
    n, i, text = np.uint64(len(x)), _NONE, np.uint64(x.ctypes.data)
    stop = n - _REACH if n > _REACH else _NONE
    count = breaks = others = _NONE
    while True:
        while i < n and (x[i] == 32 or 9 <= x[i] <= 13):
            if x[i] == 10 or x[i] == 13:
                lines[breaks] = count
                breaks += _ONE
            i += _ONE
        if i >= n:
            return count, breaks, others
        # As many decimals as the number before are tried first: where that mostly succeeds, the
        # processor begins with the next number before it has looked at these.
        decimals = _ONE
        while i < stop:
            front = load(text + i)
            before = zeros_below(~front & _DIGIT_BUT_FIRST) // _EIGHT
            point = i + before
            if before == _EIGHT or x[point] != 46:
                break
            behind = load(text + point + _ONE)
            end = point + _ONE + decimals
            if x[end] > 32:
                decimals = zeros_below(~behind & _DIGIT) // _EIGHT
                end = point + _ONE + decimals
            if decimals == _NONE:
                break
            negative = x[i] == 45
            if negative:
                front ^= _SIGN
            left = (front ^ _ZEROS) << (_ALL_BITS - _EIGHT * before)
            right = (behind ^ _ZEROS) << (_ALL_BITS - _EIGHT * decimals)
            if (left | (left + _SIX) | right | (right + _SIX)) & _HIGH:
                break
            if x[end] != 32:
                if x[end] == 10:
                    lines[breaks] = count + _ONE
                    breaks += _ONE
                elif x[end] != 9:
                    break
            # All exact but the division: no sum has more than 15 digits.
            scale = powers[decimals]
            value = eight_digits(left) * scale + eight_digits(right)
            values[count] = value / (-scale if negative else scale)
            count += _ONE
            i = end + _ONE
        if i >= n or x[i] == 32 or 9 <= x[i] <= 13:
            continue
        start = i
        negative = x[i] == 45
        if negative:
            i += _ONE
        whole, digits, power = _NONE, _NONE, np.int64(0)
        while i < n and np.uint8(x[i] - 48) < 10:
            whole = whole * _TEN + np.uint64(x[i] - 48)
            digits += _ONE
            i += _ONE
        if i < n and x[i] == 46:
            i += _ONE
            point = i
            while i < n and np.uint8(x[i] - 48) < 10:
                whole = whole * _TEN + np.uint64(x[i] - 48)
                i += _ONE
            digits += i - point
            power = -np.int64(i - point)
        plain = _NONE < digits <= _MOST_DIGITS and whole <= _EXACT
        if i < n and x[i] | 32 == 101:
            i += _ONE
            below = i < n and x[i] == 45
            if i < n and (x[i] == 45 or x[i] == 43):
                i += _ONE
            exponent, first = np.int64(0), i
            while i < n and np.uint8(x[i] - 48) < 10:
                if exponent < 1000:
                    exponent = exponent * 10 + np.int64(x[i] - 48)
                i += _ONE
            plain = plain and i > first
            power += -exponent if below else exponent
        if plain and -23 < power < 23 and (i >= n or x[i] == 32 or 9 <= x[i] <= 13):
            value = whole * powers[power] if power > 0 else whole / powers[-power]
            values[count] = -value if negative else value
        else:
            while i < n and not (x[i] == 32 or 9 <= x[i] <= 13):
                i += _ONE
            odd[others, 0], odd[others, 1], odd[others, 2] = count, start, i
            others += _ONE
        count += _ONE
