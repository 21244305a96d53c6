#include "tests/bench/noise.hpp"

#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox::bench;

TEST_CASE("what this process and its programs do is no noise", "[bench][noise]") {
    const terravox::test::TemporaryFolder folder;
    ChildRunner children;
    const NoiseMeter meter(children);
    const auto outcome =
        children.run({"sh", "-c", "i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done"},
                     folder.path() / "said.txt");
    CHECK(outcome.exit_code == 0);
    CHECK(children.cpu_s() == Approx(outcome.user_s + outcome.system_s));
    // Others may be busy while this test runs, but never with a negative number of cores where
    // /proc/stat is there.
    CHECK(meter.others_cores() >= 0);
}
