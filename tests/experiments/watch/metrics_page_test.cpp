#include "experiments/watch/metrics_page.h"

#include <gtest/gtest.h>

namespace romano::experiments::metrics_page_test {
namespace {

TEST(MetricsPage, ReadsNamesLabelsAndNumbers) {
    const MetricsPage page(
        "# HELP a What it is.\n# TYPE a counter\n"
        "a{type=\"PUBLISH\"} 5\na{type=\"PUBACK\",more=\"q\\\"\\\\ \\n\"} 7.5\nplain 1e+09\n");
    ASSERT_EQ(page.all("a").size(), 2u);
    EXPECT_EQ(page.value("a", "type", "PUBACK"), 7.5);
    EXPECT_EQ(page.all("a")[1].labels.at("more"), "q\"\\ \n");
    EXPECT_EQ(page.sum("a"), 12.5);
    EXPECT_EQ(page.value("plain"), 1e9);
    EXPECT_FALSE(page.has("b"));
    EXPECT_EQ(page.value("b", 3), 3);
}

TEST(MetricsPage, PassesOverWhatIsNoSample) {
    for (const char* text : {"", "\n\n", "a", "a{", "a{b", "a{b=\"", "a{b=\"c\"", "a{b=\"c\"}",
                             "a x", "a{b=\"c\"} ", "a{b=c} 1", "a{b=\"\\"}) {
        EXPECT_FALSE(MetricsPage(text).has("a")) << text;
    }
}

}  // namespace
}  // namespace romano::experiments::metrics_page_test
