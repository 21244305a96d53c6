#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/util/files.hpp"
#include "common/util/process.hpp"

namespace terravox::jobs {

/// What a process is started with.
struct ProcessStart {
    std::filesystem::path program;
    std::vector<std::string> words;  ///< arguments; they are not interpreted by a shell
    std::filesystem::path folder;    ///< working directory, and of temporary files
    /// Variables in addition to those of this process, of which those named TERRAVOX_SERVER_... are
    /// left out.
    std::vector<std::pair<std::string, std::string>> environment;
    std::uint64_t max_file_bytes = 0;  ///< of each file that it writes
};

/// A process that works for this one: at a lower priority, without input, in its own process group.
/// It gets SIGTERM when the thread that made the object ends. Not thread-safe.
class JobProcess {
public:
    /// @throws Error when it cannot be started
    explicit JobProcess(const ProcessStart& start);
    ~JobProcess() { stop(); }

    /// Takes what it has printed. Never blocks.
    /// @return its status once it has ended: 0 to 255, or 128 plus the signal that ended it
    [[nodiscard]] std::optional<int> look();
    /// Ends it: SIGTERM, and after some seconds SIGKILL.
    void stop() noexcept;
    /// The last kilobytes of its standard error so far.
    [[nodiscard]] const std::string& said() const noexcept { return m_said; }
    /// Its resident memory; 0 where the system does not tell.
    [[nodiscard]] std::uint64_t resident_bytes() const;

private:
    void read_what_it_says();
    util::Descriptor m_output;
    std::optional<util::Process> m_process;
    std::string m_said;
};

/// @param said by `terravox analyse` on standard error
/// @return the share of its work that is done, 0 to 1; nullopt where it has not told
[[nodiscard]] std::optional<double> progress_in(const std::string& said);
/// @return its last line, without the program's name: the reason of a failure; empty: none. It is
/// printable, and of a bounded length: it may repeat what a world or a client has said.
[[nodiscard]] std::string reason_in(const std::string& said);

}  // namespace terravox::jobs
