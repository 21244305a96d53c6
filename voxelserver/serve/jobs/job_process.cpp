#include "voxelserver/serve/jobs/job_process.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <string_view>

#include "common/util/process_memory.hpp"
#include "common/util/text.hpp"

extern char** environ;

namespace terravox::jobs {
namespace {

constexpr std::size_t kMaxSaid = 4096;
constexpr std::size_t kMaxReason = 300;

/// Whether a child must not have a variable of the server's: secrets, and proxies, which cannot
/// reach this machine's loopback address.
bool is_withheld(std::string_view name) {
    return name.starts_with("TERRAVOX_SERVER_") || name == "TMPDIR" || name.ends_with("_proxy") ||
           name.ends_with("_PROXY");
}

std::vector<std::string> make_environment(const ProcessStart& start) {
    std::vector<std::string> out;
    for (char** one = environ; *one != nullptr; ++one)
        if (const std::string_view text = *one; !is_withheld(text.substr(0, text.find('='))))
            out.emplace_back(text);
    out.push_back("TMPDIR=" + start.folder.string());
    for (const auto& [name, value] : start.environment)
        out.push_back(name + "=" + value);
    return out;
}

}  // namespace

JobProcess::JobProcess(const ProcessStart& start) {
    util::Pipe output = util::open_pipe("start " + start.program.string());
    util::Command command{start.program.string()};
    command.insert(command.end(), start.words.begin(), start.words.end());
    m_process.emplace(util::Process::Start{.command = std::move(command),
                                           .folder = start.folder,
                                           .environment = make_environment(start),
                                           .output = output.writing.get(),
                                           .errors = output.writing.get(),
                                           .confinement = {{start.max_file_bytes}}});
    m_output = std::move(output.reading);
    ::fcntl(m_output.get(), F_SETFL, O_NONBLOCK);
}

void JobProcess::read_what_it_says() {
    std::array<char, 4096> part{};
    for (ssize_t n = 0; (n = ::read(m_output.get(), part.data(), part.size())) > 0;) {
        m_said.append(part.data(), static_cast<std::size_t>(n));
        if (m_said.size() > kMaxSaid)
            m_said.erase(0, m_said.size() - kMaxSaid);
    }
}

std::optional<int> JobProcess::look() {
    const std::optional<int> status = m_process->wait(std::chrono::milliseconds(0));
    read_what_it_says();
    return status;
}

void JobProcess::stop() noexcept {
    m_process->stop(std::chrono::seconds(5));
}

std::uint64_t JobProcess::resident_bytes() const {
    return util::resident_bytes(std::to_string(m_process->id()));
}

std::optional<double> progress_in(const std::string& said) {
    constexpr std::string_view kSign = " %  tile ";
    const std::size_t at = said.rfind(kSign);
    if (at == std::string::npos)
        return std::nullopt;
    int percent = 0;
    int factor = 1;
    for (std::size_t i = at; i > 0 && said[i - 1] >= '0' && said[i - 1] <= '9' && factor <= 100;
         --i) {
        percent += (said[i - 1] - '0') * factor;
        factor *= 10;
    }
    return percent > 100 ? 1 : percent / 100.0;
}

std::string reason_in(const std::string& said) {
    std::size_t end = said.size();
    while (end > 0 && said[end - 1] == '\n')
        --end;
    const std::size_t newline = end == 0 ? std::string::npos : said.rfind('\n', end - 1);
    const std::size_t begin = newline == std::string::npos ? 0 : newline + 1;
    std::string line = said.substr(begin, end - begin);
    constexpr std::string_view kName = "terravox: ";
    if (line.starts_with(kName))
        line.erase(0, kName.size());
    return util::printable(line.substr(0, kMaxReason));
}

}  // namespace terravox::jobs
