#include "server/fields.hpp"

#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "support/input_error.hpp"

namespace livermark::server {
namespace {

TEST(Fields, AreReadAsABrowserWritesThem) {
    EXPECT_EQ(parse_fields(""), Fields{});
    EXPECT_EQ(parse_fields("file=a%20b%2Fc+d%25.h5&e=&f&&g=1=2"),
              (Fields{{"file", "a b/c d%.h5"}, {"e", ""}, {"f", ""}, {"g", "1=2"}}));
}

TEST(Fields, ComeBackFromTheirText) {
    const Fields fields{{"fault", "a & b = \"50 %\" + µ\n"}, {"ä b", std::string("\0~", 2)}};
    EXPECT_EQ(parse_fields(fields_text(fields)), fields);
    EXPECT_EQ(fields_text({{"fault", "x.h5: 5 %, µ"}}), "fault=x.h5%3A+5+%25%2C+%C2%B5");
}

TEST(Fields, AreRefusedWhereTheyAreNotWellFormed) {
    for (const auto *text : {"a=%", "a=%2", "a=%zz", "a=%-1", "%=1", "a=1&a=1"})
        EXPECT_THROW(parse_fields(text), support::InputError) << text;
}

TEST(Fields, GiveTheNumbersBetweenCommas) {
    EXPECT_EQ(required_numbers({{"x", "1"}}, "x"), std::vector{1.0});
    EXPECT_EQ(required_numbers({{"x", "-1e-3,0,2.5"}}, "x"), (std::vector{-1e-3, 0.0, 2.5}));
    for (const auto *value : {"", ",", "1,", ",1", "1,,2", "1,x", "1 ,2", "nan", "1,inf", "1e999"})
        EXPECT_THROW(required_numbers({{"x", value}}, "x"), support::InputError) << value;
}

TEST(Fields, GiveNumbersOfTheirRangeOnly) {
    EXPECT_EQ(required_number({{"e", "4e3"}}, "e", 1.0, 1e9), 4000.0);
    EXPECT_EQ(required_number({{"nu", "0"}}, "nu", 0.0, 0.49), 0.0);
    for (const auto *value : {"", " 1", "1 ", "1x", "x", "nan", "inf", "-inf", "0.49999", "-1e-300", "1e999", "0x1"})
        EXPECT_THROW(required_number({{"nu", value}}, "nu", 0.0, 0.49), support::InputError) << value;
    EXPECT_THROW(required_number({{"n", "0"}}, "nu", 0.0, 0.49), support::InputError);
    EXPECT_EQ(required_text({{"file", "a"}}, "file"), "a");
    EXPECT_THROW(required_text({{"file", ""}}, "file"), support::InputError);
}

} // namespace
} // namespace livermark::server
