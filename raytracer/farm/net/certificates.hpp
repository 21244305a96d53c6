#pragma once

#include <grpcpp/security/auth_context.h>
#include <openssl/x509.h>
#include <array>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace terravox::net {

/// Roles that a certificate may grant. The role is in the certificate as a URI among its
/// alternative names: kRoleUri and the role.
inline constexpr std::string_view kWorkerRole = "worker";  ///< renders for coordinators
/// has pictures rendered; queries states, and pauses
inline constexpr std::string_view kCoordinatorRole = "coordinator";
inline constexpr std::string_view kRoleUri = "urn:terravox:farm:";

/// @return kWorkerRole, kCoordinatorRole, or empty: it names none
[[nodiscard]] std::string find_role(X509* certificate);

/// The list of revoked certificates of a CA (X.509 CRL, PEM), which is next to it: ca.crl for
/// ca.pem. It is read for each connection, and again for existing ones once its file has changed
/// (RevocationWatch).
[[nodiscard]] std::filesystem::path find_revocation_list(const std::filesystem::path& ca);

/// What a certificate states about its owner.
struct Certified {
    std::string role;  ///< kWorkerRole or kCoordinatorRole
    std::string name;  ///< its common name
    std::string pem;   ///< all of it
};

/// The contents of the certificate of the other end of a TLS connection, which gRPC has verified to
/// be of this CA.
/// @param ca file of the CA's certificate
/// @throws RefusedError for a certificate without kFarmName or a role, or one that is revoked;
/// Error for a list of revoked ones that cannot be read, or that this CA has not signed: then no
/// peer is admitted
[[nodiscard]] Certified certified_peer(const grpc::AuthContext& context,
                                       const std::filesystem::path& ca);

/// Checks whether an admitted certificate has been revoked since. Thread-safe.
///
/// A check costs a stat() while the list's file is unchanged. A list that cannot be read, such as
/// one that is just being copied, is logged and read again with the next check; until then existing
/// links stay, while new connections are refused.
class RevocationWatch {
public:
    /// @param certificate PEM
    /// @param ca file of the CA's certificate
    RevocationWatch(std::string certificate, std::filesystem::path ca);
    [[nodiscard]] bool is_revoked();

private:
    /// Identifies a version of a file: device, inode, size, and times of content and inode in ns;
    /// nullopt: there is no file.
    using Stamp = std::optional<std::array<std::int64_t, 5>>;
    [[nodiscard]] static Stamp make_stamp(const std::filesystem::path& file) noexcept;

    const std::string m_certificate;
    const std::filesystem::path m_ca;
    const std::filesystem::path m_list;
    std::mutex m_mutex;
    /// Of the list that was read last, and of the last one that could not be.
    Stamp m_read;
    Stamp m_reported;
    bool m_revoked = false;
};

inline constexpr int kMaxCertificate_days = 3650;

/// Makes certificates for a farm: a CA of its own if the folder has none (ca.pem, ca.key; valid for
/// ten years), and for each name NAME.pem and NAME.key. All carry the DNS name "terravox-farm" in
/// addition to their own, and a role, which each end checks; the role does
/// not depend on which side listens and which dials. ca.key is used to make more certificates and
/// is needed on no machine of the farm. Keys (P-256) are readable by their owner alone. Existing
/// files are not changed.
/// @param names of small letters, digits, '-' and '.', 1 to 63 characters, not "ca"; none:
/// coordinator, worker
/// @param role of all of them: kWorkerRole or kCoordinatorRole; empty: the name "coordinator" is a
/// coordinator's, all others are workers'
/// @param days 1 to kMaxCertificate_days
/// @throws UsageError for an invalid name or number; Error when a file of such a name exists or
/// cannot be written: then this call has made none
void make_certs(const std::filesystem::path& folder, const std::vector<std::string>& names,
                int days, const std::string& role = {});

/// Adds the certificates NAME.pem of the folder to the CA's list of revoked ones, ca.crl next to
/// ca.pem, which is created if there is none. The list must be copied next to ca.pem on each
/// machine: from then on new connections are refused, and existing ones end within seconds.
/// @throws UsageError for an invalid name; Error for files that cannot be read or written, or that
/// the CA has not signed
void revoke_certs(const std::filesystem::path& folder, const std::vector<std::string>& names);

}  // namespace terravox::net
