"""Register AMC: Acclaim's motion files, each with an .asf file in the same folder."""

from twistcore.formats.suffixes import FormatInfo

FORMAT = FormatInfo(".amc", read="twistcore.formats.amc:read_amc", place=30, companion=".asf")
