#include "common/util/log.hpp"

#include "common/util/error.hpp"
#include "tests/catch.hpp"

using terravox::test::contains;

TEST_CASE("the log takes six levels and names a wrong one", "[common][util][log]") {
    const auto before = spdlog::default_logger();
    struct Case { const char* name; spdlog::level::level_enum level; };
    for (const Case c : {Case{"trace", spdlog::level::trace}, Case{"debug", spdlog::level::debug}, Case{"info", spdlog::level::info},
                         Case{"warn", spdlog::level::warn}, Case{"error", spdlog::level::err}, Case{"off", spdlog::level::off}}) {
        INFO(c.name);
        terravox::util::set_up_log(c.name);
        CHECK(spdlog::default_logger()->level() == c.level);
    }
    for (const char* wrong : {"", "loud", "INFO", "warning"}) {
        INFO(wrong);
        CHECK_THROWS_AS(terravox::util::set_up_log(wrong), terravox::UsageError);
        CHECK_THROWS_WITH(terravox::util::set_up_log(wrong), contains("'" + std::string(wrong) + "'") && contains("warn, error, off"));
    }
    spdlog::set_default_logger(before);
}
