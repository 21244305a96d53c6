// main() of all tests in C++. What a test says with WARN, it leaves out: each is written to the
// file that TERRAVOX_SKIPS names, where it names one, for config/setup/test_tools.sh.
#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
using Listener = Catch::EventListenerBase;
using AssertionEnded = void;
#else
#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>
using Listener = Catch::TestEventListenerBase;
using AssertionEnded = bool;
#endif

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>  // program_invocation_short_name
#include <cstdlib>
#include <stdexcept>
#include <string>

namespace {

class Skips : public Listener {
public:
    using Listener::Listener;

    void testCaseStarting(const Catch::TestCaseInfo& test) override {
        Listener::testCaseStarting(test);
        m_test = test.name;
    }

    AssertionEnded assertionEnded(const Catch::AssertionStats& stats) override {
        const Catch::AssertionResult& result = stats.assertionResult;
        if (result.getResultType() == Catch::ResultWas::Warning)
            write_down(std::string(result.getMessage()));
        return AssertionEnded();
    }

private:
    void write_down(std::string reason) const {
        const char* const name = std::getenv("TERRAVOX_SKIPS");
        if (name == nullptr || *name == '\0')
            return;
        std::replace(reason.begin(), reason.end(), '\n', ' ');
        const std::string line =
            std::string(program_invocation_short_name) + '\t' + m_test + '\t' + reason + '\n';
        // One write, so that lines of tests that run at the same time do not mix.
        const int file = ::open(name, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
        if (file < 0 || ::write(file, line.data(), line.size()) < 0)
            throw std::runtime_error(std::string("write down a skipped test in ") + name);
        ::close(file);
    }

    std::string m_test;
};

}  // namespace

CATCH_REGISTER_LISTENER(Skips)

int main(int argc, char** argv) {
    return Catch::Session().run(argc, argv);
}
