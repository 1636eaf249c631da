// Publishes ArmingCheckRequest with Fast DDS 2, on the loopback interface: fastdds DOMAIN
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <thread>
#include <vector>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

using namespace eprosima::fastdds::dds;
using eprosima::fastrtps::rtps::IPLocator;
using eprosima::fastrtps::rtps::Locator_t;
using eprosima::fastrtps::rtps::SerializedPayload_t;

using Message = std::vector<unsigned char>;

/// A type whose messages are serialized already.
class RawType : public TopicDataType {
public:
    RawType() {
        setName("px4_msgs::msg::dds_::ArmingCheckRequest_");
        m_typeSize = 64;
    }
    bool serialize(void* data, SerializedPayload_t* payload) override {
        const auto& message = *static_cast<Message*>(data);
        std::memcpy(payload->data, message.data(), message.size());
        payload->length = message.size();
        payload->encapsulation = CDR_LE;
        return true;
    }
    bool deserialize(SerializedPayload_t*, void*) override { return true; }
    std::function<uint32_t()> getSerializedSizeProvider(void* data) override {
        return [data] { return static_cast<Message*>(data)->size(); };
    }
    void* createData() override { return new Message; }
    void deleteData(void* data) override { delete static_cast<Message*>(data); }
    bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) override { return false; }
};

int main(int, char** arguments) {
    DomainParticipantQos qos;
    qos.name("/fast");
    auto transport = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    transport->interfaceWhiteList.push_back("127.0.0.1");
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(transport);
    const int domain = std::atoi(arguments[1]);
    for (int index = 0; index < 4; ++index) {
        Locator_t locator;
        IPLocator::setIPv4(locator, 127, 0, 0, 1);
        locator.port = 7410 + 250 * domain + 2 * index;
        qos.wire_protocol().builtin.initialPeersList.push_back(locator);
    }
    auto* participant = DomainParticipantFactory::get_instance()->create_participant(domain, qos);
    if (participant == nullptr) return 1;
    TypeSupport type(new RawType);
    type.register_type(participant);
    auto* topic = participant->create_topic("rt/fmu/out/arming_check_request_v1", type.get_type_name(), TOPIC_QOS_DEFAULT);
    DataWriterQos writer_qos;
    writer_qos.reliability().kind = BEST_EFFORT_RELIABILITY_QOS;
    writer_qos.durability().kind = TRANSIENT_LOCAL_DURABILITY_QOS;
    auto* writer = participant->create_publisher(PUBLISHER_QOS_DEFAULT)->create_datawriter(topic, writer_qos);
    if (writer == nullptr) return 1;
    const auto start = std::chrono::steady_clock::now();
    for (unsigned char id = 0;; ++id) {
        const std::uint64_t time = std::chrono::duration_cast<std::chrono::microseconds>(
            std::chrono::steady_clock::now() - start).count() + 1;
        const std::uint32_t mask = 1;
        Message message(20);
        message[1] = 1;
        std::memcpy(&message[4], &time, sizeof time);
        message[12] = id;
        std::memcpy(&message[16], &mask, sizeof mask);
        writer->write(&message);
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
}
